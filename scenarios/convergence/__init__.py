"""Convergence of rendering: how the events of coarser renderings approach those of the finest."""
