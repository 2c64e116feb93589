"""The paper's claims, each with a test on the table of the study."""
