"""Grid search on a processor, as robots run it: A*, jump points, any-angle paths, and the potential of Nav2's NavFn.

- ``plan``: the arithmetic, exact and without a clock.
- ``styles``: what it costs on a processor, and the probes of its kernels.

``styles`` imports ``plan``; never the reverse. No paper stands behind the room, so it reproduces none.
"""
