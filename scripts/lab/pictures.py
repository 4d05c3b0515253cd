"""Pictures by matplotlib, in files alone and the same for the same numbers."""


def pyplot(settings={}):
    """matplotlib.pyplot without a display; raises ImportError where there is none."""
    import matplotlib
    matplotlib.use("Agg")
    matplotlib.rcParams.update({"svg.hashsalt": "gpsrecon", **settings})
    from matplotlib import pyplot
    return pyplot


def save(figure, path, **settings):
    """As PNG or SVG, by the name."""
    if path.suffix == ".svg":
        settings["metadata"] = {"Date": None}
    figure.savefig(path, **settings)
    pyplot().close(figure)
