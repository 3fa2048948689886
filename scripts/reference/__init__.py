"""The reference pages: one module per page, each with a function `page` that returns its Markdown."""
