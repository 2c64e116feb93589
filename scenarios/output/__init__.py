"""What commands write: folders, tables, figures, pages and terminal output."""
