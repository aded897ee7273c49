"""The verification report: one self-contained page, written for an engineer who was not there.

``page`` writes it, ``sections`` lists what is in it, ``report_data`` holds what several
sections show.  Nothing is computed here that could not be had without a report.
"""
