"""Picture files: what each format holds, decoding, encoding and colour profiles; plain functions, no node."""
