"""Vacariu, Roman, Timar, Stanciu, Banabic and Cret (2008), held against the model, row by row."""
