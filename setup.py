"""The compiled part; all else is in pyproject.toml. `python setup.py build_ext --inplace` compiles
it again. A wheel is rf_nav-VERSION-cp311-abi3-PLATFORM, one for each of x86_64 and aarch64, for
every Python from 3.11 on."""

from glob import glob

from setuptools import Extension, setup

setup(
    ext_modules=[
        Extension(
            "runtime.core.kernels._compiled",
            sorted(glob("runtime/core/kernels/*.c")),
            depends=glob("runtime/core/kernels/*.h"),
            # No fused multiplications: every machine computes the same bits. Nobody asks whether
            # arithmetic raised a flag: with that alone loops with comparisons become vectors.
            extra_compile_args=[
                "-std=c11",
                "-O3",
                "-Wall",
                "-Wextra",
                "-ffp-contract=off",
                "-fno-trapping-math",
            ],
            py_limited_api=True,
        )
    ],
    options={"bdist_wheel": {"py_limited_api": "cp311"}},
)
