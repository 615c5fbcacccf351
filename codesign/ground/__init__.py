"""The ground of every room: errors, units, figures with their source, files, records of a run, caches, progress."""
