"""The figures of the study.

To add a figure, write one file here with a function `draw(path, sequences)`, which uses
`scenarios.output.figures.figure_file`, and add one entry to `FIGURES` in `all_figures.py`. Also
describe it in docs/explanation/study.md. The report and the folder of figures then include it.
"""
