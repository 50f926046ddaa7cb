"""Launch of two bodies by three formulations, and the rendezvous of two impulses in closed form."""
