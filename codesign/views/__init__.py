"""What a reader looks into: traces, reports and plots, files for other programs, ROS 2 bags."""
