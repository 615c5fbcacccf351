"""Grid search on a processor, as robots run it: A*, jump points, any-angle paths, and the potential of Nav2's NavFn.

No paper stands behind the room, so it reproduces none.
"""
