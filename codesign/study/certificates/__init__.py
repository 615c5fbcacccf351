"""The certificate of a front: the figures of every design, and for every design off the front why it is off it.

``form`` is what a certificate holds, ``file`` writes and reads it. ``check`` is the checker, and ``cover`` the part of
it that counts designs. Nothing here simulates, and nothing here imports the exploration. docs/certificates.md
describes the file so that anyone can write a second checker.
"""
