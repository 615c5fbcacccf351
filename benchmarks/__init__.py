"""Speed, as ratios measured in one run: ``make bench``. Timing decides no test."""
