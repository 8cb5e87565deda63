"""Machines of one chain: linear and rotary joints on the tool's and the part's side, in any order of sides."""
