"""report.html: every loop of a run in 3D, its tables, its failures and where all that is from.

:mod:`.scene` is what the page shows of one folder; it is written with the folder, so that a page
can be made at any time, after a resumed run too. :mod:`.write` puts a page together from folders.
"""
