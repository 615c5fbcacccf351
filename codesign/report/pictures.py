"""The pictures of one run, from its records."""

from __future__ import annotations

from collections.abc import Iterable

from codesign.records import MapRecord, Record
from codesign.report.canvas import Picture
from codesign.report.map_pictures import drive_picture, plan_picture
from codesign.report.timelines import bars_of, mission_timeline_picture, timeline_picture


def run_pictures(records: Iterable[Record]) -> tuple[Picture, ...]:
    """The pictures that these records allow, in reading order; none for a run that never began.

    A mission is shown as its drive and its time line in place of the plans' bars.
    """
    all_records = tuple(records)
    drive, busy = drive_picture(all_records), mission_timeline_picture(all_records)
    if drive is not None or busy is not None:
        return tuple(picture for picture in (drive, busy) if picture is not None)
    pictures = []
    maps = [record for record in all_records if isinstance(record, MapRecord)]
    if maps:
        pictures.append(plan_picture(maps[-1], all_records))
    bars = bars_of(all_records)
    if bars:
        pictures.append(timeline_picture(bars))
    return tuple(pictures)
