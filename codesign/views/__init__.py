"""The views of results: traces, reports and plots, files for other programs, ROS 2 bags."""
