def draw_figures(plan, folder):
    return ()
