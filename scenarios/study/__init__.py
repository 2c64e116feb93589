"""The paper's evaluation in one command: its crossings, its methods and more, and its claims."""
