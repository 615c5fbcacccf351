"""Vacariu, Roman, Timar, Stanciu, Banabic and Cret (2008) beside the model, row by row."""
