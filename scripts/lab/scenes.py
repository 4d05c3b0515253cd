"""Pictures of points and meshes, drawn by VTK."""

import os
import sys

SHARPNESS = 2  # pixels drawn for one of the picture, each way, and averaged
SAND, BLUE, RED, DARK = (0.80, 0.74, 0.64), (0.30, 0.48, 0.80), (0.80, 0.20, 0.16), (0.25, 0.25, 0.25)


def in_display():
    """Starts the script again in a virtual display if there is none: VTK draws through X. The display outlasts each
    window; else it would begin anew while the next one opens."""
    if os.environ.get("DISPLAY"):
        return
    os.execvp("xvfb-run", ["xvfb-run", "-a", "-s", "-screen 0 1600x1200x24 -noreset", sys.executable, *sys.argv])


def read(path):
    """A PLY file as vtkPolyData; files without faces get a vertex cell for each point."""
    from vtkmodules.vtkFiltersGeneral import vtkVertexGlyphFilter
    from vtkmodules.vtkIOPLY import vtkPLYReader
    reader = vtkPLYReader()
    reader.SetFileName(str(path))
    reader.Update()
    data = reader.GetOutput()
    if data.GetNumberOfPolys() == 0:
        glyphs = vtkVertexGlyphFilter()
        glyphs.SetInputData(data)
        glyphs.Update()
        data = glyphs.GetOutput()
    return data


def shaded(data, direction, color=(0.62, 0.55, 0.44)):
    """Points with normals in colours as if they were lit; those that face away from `direction` are pale."""
    import numpy as np
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    direction = np.array(direction, float) / np.linalg.norm(direction)
    facing = vtk_to_numpy(data.GetPointData().GetNormals()) @ direction
    bright = np.where(facing > 0, 0.35 + 0.65 * facing, 0)[:, None] * np.array(color)
    colors = np.where(facing[:, None] > 0, bright, 0.82)
    scalars = numpy_to_vtk((255 * colors).astype(np.uint8), deep=True)
    scalars.SetName("RGB")
    data.GetPointData().SetScalars(scalars)
    data.GetPointData().SetNormals(None)
    return data


class Panel:
    """One part of a picture: actors with a caption below."""

    def __init__(self, caption=""):
        self.caption, self.actors = caption, []

    def add(self, data, color=SAND, colored=False, flat=False, edges=False, back=None, size=2):
        """Points or faces of one color, or `colored` by the colours in the file; `flat` shades faces and not vertices,
        `edges` draws them, `back` is the colour of back faces, `size` that of points in pixels."""
        import vtkmodules.vtkRenderingOpenGL2  # noqa: F401 (mappers are registered by importing it)
        from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper, vtkProperty
        mapper = vtkPolyDataMapper()
        mapper.SetInputData(data)
        mapper.SetScalarVisibility(colored)
        actor = vtkActor()
        actor.SetMapper(mapper)
        look = actor.GetProperty()
        look.SetColor(*color)
        look.SetPointSize(SHARPNESS * size)
        look.SetAmbient(0.6 if colored else 0.3)
        look.SetDiffuse(0.5 if colored else 0.75)
        if data.GetNumberOfPolys() == 0:
            look.LightingOff()
        if flat:
            look.SetInterpolationToFlat()
        if edges:
            look.EdgeVisibilityOn()
            look.SetEdgeColor(*DARK)
            look.SetLineWidth(SHARPNESS * 0.7)
        if back:
            behind = vtkProperty()
            behind.DeepCopy(look)
            behind.SetColor(*back)
            actor.SetBackfaceProperty(behind)
        self.actors.append(actor)
        return self

    def add_boundary(self, data, color=RED, width=3):
        """The boundary edges of a mesh."""
        from vtkmodules.vtkFiltersCore import vtkFeatureEdges
        from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper
        edges = vtkFeatureEdges()
        edges.SetInputData(data)
        edges.BoundaryEdgesOn()
        edges.FeatureEdgesOff()
        edges.ManifoldEdgesOff()
        edges.NonManifoldEdgesOff()
        edges.ColoringOff()
        mapper = vtkPolyDataMapper()
        mapper.SetInputConnection(edges.GetOutputPort())
        mapper.ScalarVisibilityOff()
        mapper.SetResolveCoincidentTopologyToPolygonOffset()
        actor = vtkActor()
        actor.SetMapper(mapper)
        actor.GetProperty().SetColor(*color)
        actor.GetProperty().SetLineWidth(SHARPNESS * width)
        actor.GetProperty().LightingOff()
        self.actors.append(actor)
        return self


def add_caption(renderer, caption, width, size):
    """A line of text of `size` pixels at the foot of a view `width` pixels wide."""
    from vtkmodules.vtkRenderingCore import vtkTextActor
    text = vtkTextActor()
    text.SetInput(caption)
    look = text.GetTextProperty()
    look.SetColor(0, 0, 0)
    look.SetFontSize(size)
    look.SetJustificationToCentered()
    text.SetPosition(width / 2, 0.4 * size)
    renderer.AddActor2D(text)


def set_lights(renderer, lights):
    """Lights alone that move with the camera: pairs of a place beside it and an intensity."""
    from vtkmodules.vtkRenderingCore import vtkLight
    renderer.RemoveAllLights()
    renderer.AutomaticLightCreationOff()
    for offset, intensity in lights:
        light = vtkLight()
        light.SetLightTypeToCameraLight()
        light.SetPosition(*offset)
        light.SetFocalPoint(0, 0, 0)
        light.SetIntensity(intensity)
        renderer.AddLight(light)


def write(window, path, shrink=1):
    """Renders a window into a PNG file, `shrink` pixels averaged into one each way, and tells its size."""
    from vtkmodules.vtkImagingCore import vtkImageShrink3D
    from vtkmodules.vtkIOImage import vtkPNGWriter
    from vtkmodules.vtkRenderingCore import vtkWindowToImageFilter
    window.Render()
    image = vtkWindowToImageFilter()
    image.SetInput(window)
    image.ReadFrontBufferOff()
    small = vtkImageShrink3D()
    small.SetInputConnection(image.GetOutputPort())
    small.SetShrinkFactors(shrink, shrink, 1)
    small.MeanOn()
    writer = vtkPNGWriter()
    writer.SetFileName(str(path))
    writer.SetCompressionLevel(9)
    writer.SetInputConnection(small.GetOutputPort())
    writer.Write()
    window.Finalize()
    print(f"  {path.name}: {path.stat().st_size / 1000:.0f} kB", flush=True)


def draw(path, panels, direction, up, box, size=(480, 400), zoom=1.0):
    """Panels side by side as a PNG file, all seen from `direction` at the scale at which `box`, the bounds (x0, x1, y0,
    y1, z0, z1), fills a panel of `size` pixels."""
    import vtkmodules.vtkRenderingFreeType  # noqa: F401 (implementations are registered by importing them)
    import vtkmodules.vtkRenderingOpenGL2  # noqa: F401
    from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow
    import numpy as np

    direction, up = (np.array(v, float) / np.linalg.norm(v) for v in (direction, up))
    right = np.cross(up, direction)
    right /= np.linalg.norm(right)
    true_up = np.cross(direction, right)
    low, high = np.array(box[0::2]), np.array(box[1::2])
    center, half = 0.5 * (low + high), 0.5 * (high - low)
    extent_up, extent_right = np.abs(true_up) @ half, np.abs(right) @ half
    margin = 24 if any(panel.caption for panel in panels) else 0

    window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetSize(SHARPNESS * len(panels) * size[0], SHARPNESS * size[1])
    for number, panel in enumerate(panels):
        renderer = vtkRenderer()
        renderer.SetViewport(number / len(panels), 0, (number + 1) / len(panels), 1)
        renderer.SetBackground(1, 1, 1)
        for actor in panel.actors:
            renderer.AddActor(actor)
        add_caption(renderer, panel.caption, SHARPNESS * size[0], SHARPNESS * 15)
        set_lights(renderer, (((0.4, 0.8, 1.0), 0.9), ((-0.9, 0.1, 0.7), 0.4)))
        camera = renderer.GetActiveCamera()
        camera.ParallelProjectionOn()
        scale = max(extent_up * size[1] / (size[1] - margin), extent_right * size[1] / size[0]) / zoom
        focus = center - scale * margin / size[1] * true_up
        camera.SetFocalPoint(*focus)
        camera.SetPosition(*(focus + 10 * np.linalg.norm(high - low) * direction))
        camera.SetViewUp(*true_up)
        camera.SetParallelScale(scale)
        renderer.ResetCameraClippingRange()
        window.AddRenderer(renderer)
    write(window, path, SHARPNESS)
