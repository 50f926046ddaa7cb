"""The impulses that cost least by conic problems, and the order in which all servers leave."""
