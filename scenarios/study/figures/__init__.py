"""The figures of the study.

To add a figure, write one file here with a function that draws it, and add one entry to `FIGURES`
in `all_figures.py`. The report and the folder of figures then include it.
"""
