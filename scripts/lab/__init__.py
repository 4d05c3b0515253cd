"""What the scripts of this folder share: running programs (runner), virtual scans and their truth (scans), PLY files
(ply), Markdown tables and the measured sections of pages (pages), pictures (pictures)."""
