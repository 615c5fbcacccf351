"""Saudi and Sulaiman (2016), held against the model, row by row."""
