"""A page as one self-contained HTML file: `rendering`, its template `page.html`, its style `page.css`."""
