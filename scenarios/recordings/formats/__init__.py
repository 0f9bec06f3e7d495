"""Recording formats, one file each; `format_choice` selects one by the names of the files."""
