# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake whose transforms are computed by compute shaders."""

import bpy
import numpy as np
import pytest

from tests.support.blender import extension

#: Heights of incommensurate waves: no symmetry that a wrong transform could hide behind.
SIZE_M = (6.0e-6, 5.0e-6)


@pytest.fixture
def blender(empty_blender):
    """`bpy` with the add-on and a GPU context."""
    package = extension.load()
    package.register()
    from diffraction_shader.addon.tables.gpu import device
    from diffraction_shader.precompute.errors import ParameterError

    try:
        device.use_gpu("GPU")
    except ParameterError as error:
        package.unregister()
        pytest.skip(f"no OpenGL on this machine: {error}")
    yield empty_blender
    package.unregister()


@pytest.fixture
def patch(blender):
    """A small prepared patch whose sides have different lengths and prime factors."""
    from diffraction_shader.precompute.scan.heightfield import HeightField

    rows, cols = 66, 91
    y, x = np.mgrid[:rows, :cols] / np.array([rows, cols])[:, None, None]
    rng = np.random.default_rng(5)
    heights = 6e-8 * np.sin(2 * np.pi * (5.3 * x + 2.1 * y)) + 2e-8 * rng.standard_normal((rows, cols))
    return HeightField(heights, SIZE_M[0] / cols, SIZE_M[1] / rows)


@pytest.fixture
def scan(patch, tmp_path):
    """The patch as a file."""
    from diffraction_shader.precompute.scan.gsf import write_gsf

    path = tmp_path / "waves.gsf"
    write_gsf(patch, path)
    return path


def truth(patch, sigma_s_m, kappa, axes):
    """sum over all lags D of R(D) exp(-D^2 / 4 sigma_s^2) exp(2 pi i f.D) in double precision, from the definition."""
    from scipy.signal.windows import tukey

    rows, cols = patch.shape
    p = np.exp(-1j * kappa * patch.heights) * np.outer(tukey(rows, 0.2), tukey(cols, 0.2))
    size = 2 * rows, 2 * cols
    spectrum = np.fft.fft2(p, size)
    lags = np.fft.ifft2(np.abs(spectrum) ** 2)  # sum conj(p)(x) p(x + D)
    dy = np.fft.fftfreq(size[0], 1.0 / size[0]) * patch.dy
    dx = np.fft.fftfreq(size[1], 1.0 / size[1]) * patch.dx
    lags *= np.exp(-(dy[:, None] ** 2 + dx**2) / (4 * sigma_s_m**2))
    fy, fx = axes
    return np.real(np.exp(2j * np.pi * np.outer(fy, dy)) @ lags @ np.exp(2j * np.pi * np.outer(dx, fx)))


def test_intensity_of_the_gpu_is_that_of_plain_sums(patch):
    from diffraction_shader.addon.tables.gpu.transforms import GpuTransforms
    from diffraction_shader.precompute.bake.intensity import PolarIntensity

    sigma_s, kappas = 0.4e-6, np.array([4e6, 2.9e7])
    polar = PolarIntensity(patch, sigma_s, "average")
    transforms = GpuTransforms(lambda function: function(), race=False)
    coefficients = transforms(polar, kappas)
    assert transforms.device == "GPU"
    angles = np.array([0.3, 1.9, 4.4])
    found = polar.polar(coefficients, angles)[..., 0].T  # at the kappa that the trial did not compute
    reached = polar.frequencies < 2 / 380e-9
    for index, angle in enumerate(angles):
        f = polar.frequencies[reached]
        wanted = np.array(
            [truth(patch, sigma_s, kappas[0], ([g * np.sin(angle)], [g * np.cos(angle)]))[0, 0] for g in f]
        )
        area = np.sum(np.outer(*polar.window_axes) ** 2)
        wanted *= patch.dx * patch.dy / area
        assert found[reached, index] == pytest.approx(wanted, abs=2e-3 * wanted.max())
    transforms.close()


def bake(scan, folder, name, device):
    from diffraction_shader.addon.tables.bake_job import BakeJob
    from diffraction_shader.precompute.parameters import BakeParameters

    return BakeJob(scan, folder, name, BakeParameters(sigma_s_m=0.5e-6), {}, device=device)


def test_table_of_the_gpu_is_the_processors(scan, tmp_path):
    by_gpu, by_processor = bake(scan, tmp_path, "gpu", "GPU"), bake(scan, tmp_path, "cpu", "CPU")
    found, wanted = by_gpu.run().table, by_processor.run().table
    assert (by_gpu.device, by_processor.device) == ("GPU", "processor")
    assert found.layout.to_dict() | {"scale": 0} == wanted.layout.to_dict() | {"scale": 0}
    assert found.layout.scale == pytest.approx(wanted.layout.scale, rel=1e-6)
    a, b = found.atlas.astype(float), wanted.atlas.astype(float)
    # Single precision leaves 1e-7 of the specular peak, on either device; above that half floats are the limit.
    assert np.all(np.abs(a - b) <= np.maximum(1e-3 * b, 1e-7 * b.max()))
    assert np.median(np.abs(a - b)) == 0.0
    by_gpu.close()


def test_bake_in_a_thread_uses_the_gpu_from_the_main_thread(scan, tmp_path):
    job = bake(scan, tmp_path, "threaded", "GPU")
    job.start()
    while job.running:
        job.serve()
    threaded = job.result()
    assert job.device == "GPU"
    job.close()
    blocking = bake(scan, tmp_path, "blocking", "GPU").run()
    assert threaded.path.read_bytes() == blocking.path.read_bytes().replace(b"blocking", b"threaded")


def test_stopped_thread_does_not_wait_for_the_gpu_for_ever(scan, tmp_path):
    from diffraction_shader.precompute.errors import Cancelled

    job = bake(scan, tmp_path, "x", "GPU")
    job.start()
    job.cancel()  # nobody serves
    with pytest.raises(Cancelled):
        job.result()
    job.close()
    assert not list(tmp_path.glob("x.*"))


@pytest.mark.parametrize(
    ("trouble", "reason"), [("wrong", "wrong by"), ("small", "textures end at 64"), ("slow", "as long")]
)
def test_gpu_that_cannot_leaves_the_bake_to_the_processor(scan, tmp_path, monkeypatch, trouble, reason):
    import gpu
    from diffraction_shader.addon.tables.gpu import transforms

    if trouble == "wrong":
        right = transforms._Plan.run
        monkeypatch.setattr(transforms._Plan, "run", lambda plan, kappa: 1.001 * right(plan, kappa))
    elif trouble == "small":
        monkeypatch.setattr(gpu.capabilities, "max_texture_size_get", lambda: 64)
    else:
        right = transforms._Plan.run
        monkeypatch.setattr(
            transforms._Plan, "run", lambda plan, kappa: (transforms.time.sleep(0.5), right(plan, kappa))[1]
        )
    job = bake(scan, tmp_path / "tried", "waves", "GPU")
    if trouble == "slow":
        job._transforms._race = True
    tried = job.run().path.read_bytes()
    assert job.device.startswith("processor: ")
    assert reason in job.device
    assert tried == bake(scan, tmp_path / "plain", "waves", "CPU").run().path.read_bytes()
    job.close()


def test_automatic_takes_hardware_only(blender, monkeypatch):
    import gpu
    from diffraction_shader.addon.tables.gpu import device

    monkeypatch.setattr(gpu.platform, "device_type_get", lambda: "SOFTWARE")
    assert not device.use_gpu("AUTO")
    monkeypatch.setattr(gpu.platform, "device_type_get", lambda: "DISCRETE")
    assert device.use_gpu("AUTO")
    assert not device.use_gpu("CPU")


def test_automatic_makes_no_context(blender, monkeypatch):
    import gpu
    from diffraction_shader.addon.tables.gpu import device

    def nothing():
        raise SystemError("no context")

    monkeypatch.setattr(gpu.platform, "renderer_get", nothing)
    monkeypatch.setattr(device, "ensure_gpu", lambda: pytest.fail("made a context"))
    assert not device.use_gpu("AUTO")


def test_operator_tells_what_baked(scan, tmp_path, capfd):
    import gpu

    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    bpy.ops.diffraction.import_scan(filepath=str(scan))
    assert bpy.ops.diffraction.bake(sigma_s_um=0.5, device="GPU") == {"FINISHED"}
    assert "(GPU)" in capfd.readouterr().out
    assert bpy.ops.diffraction.bake(sigma_s_um=0.6) == {"FINISHED"}
    if gpu.platform.device_type_get() == "SOFTWARE":
        assert "(processor)" in capfd.readouterr().out
