"""Example-based texture synthesis and editing as a node-graph dataflow framework."""
