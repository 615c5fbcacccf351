"""What every room stands on: errors, units, figures with their source, files, records of a run, caches, progress."""
