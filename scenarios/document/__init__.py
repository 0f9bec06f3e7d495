"""Model of every page: a document of sections, rendered for terminals, browsers, Markdown, LaTeX and JSON."""
