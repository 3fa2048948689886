"""The lost Table 1 as an inverse problem: parts of identify_table1.py."""
