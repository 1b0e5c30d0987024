"""Thousands of files: the same work on each, here or on dask's workers, in any order, resumable.

    sources → tasks → (workers) → records → journal → one table

A *record* is what became of one file: rows of the table, and sentences for what failed. It goes to
the journal, one line of JSON, as soon as it comes; the table follows row by row and is put in the
order of the input when all is done. A run that is killed therefore loses at most the files that
were being worked on, and the next run on the same folder does those only.
"""
