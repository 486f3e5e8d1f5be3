"""Parts of `canalyze fleet`; `commands/fleet.py` combines them. None of them knows the meaning of a frame.

stores.py  folders and object stores behind one interface; the captures in them, their hashes, and their download
task.py    one capture -> its manifest: the work of a worker, on any machine; the manifest decides if work is done
run.py     all captures through an executor: a window of them, retries, quarantine; the manifests as reports
"""
