"""`rfnav mcp`: what language-model agents may ask the robot for, by the Model Context Protocol."""
