"""A trace for other tools and for the terminal.

Perfetto, waveforms, tables of poses; statistics, differences and Gantt charts.

All of them read records. What a record says of a component's time stands in one place, ``codesign/ground/activity.py``.
"""
