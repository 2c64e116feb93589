"""The study: the paper's evaluation, its crossings, methods, figures and claims."""
