"""Programs of Siemens SINUMERIK 840D and ONE controls: their own text, expressions, flow, frames and cycles."""
