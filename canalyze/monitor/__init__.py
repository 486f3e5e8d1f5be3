"""The screen of `canalyze monitor`; the only package that imports textual.

opening.py    what is watched: the thread that reads it, and its state
app.py        the application: the layout of the views, actions of keys, the refresh of the screen
grid.py       a table whose cells are updated in place; the base of all views; numbers and bars in few columns
views.py      from a snapshot of the core to rows: nodes, objects, transfers, findings, problems
trace.py      the view of annotated frames: following, scrolled back, filtered, searched
around.py     lines above and below the views; all keys and their actions; pages over the screen; the prompt

Nothing here decodes or judges: the meaning of frames, and every figure, comes from `Session.snapshot` and `.trace`.
Names from devices and files are drawn as text, never as markup, and escaped where they could control a terminal.
"""
