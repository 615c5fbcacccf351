"""What each scenario of a workload makes a machine do, one module each."""
