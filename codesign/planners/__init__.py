"""Planners: what is computed, exactly and without a clock. One module or package per paper."""
