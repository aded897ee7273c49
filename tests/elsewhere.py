"""Run pytest as other processors would: with the instructions that they have.

    python tests/elsewhere.py [arguments of pytest]

OpenBLAS, MKL and numpy each choose their code by the processor they find; told to do without its
wider instructions they sum in the order of an older one.  A test that passes in all of these passes
on machines that are not at hand, unless it holds rounding against a number.
"""

import os
import subprocess
import sys

from numpy._core._multiarray_umath import __cpu_dispatch__, __cpu_features__

#: By name: what OpenBLAS and MKL are told, and what numpy keeps of the instructions it may choose.
PROCESSORS = {
    "AVX2": ({"OPENBLAS_CORETYPE": "Haswell", "MKL_ENABLE_INSTRUCTIONS": "AVX2"}, {"X86_V3"}),
    "SSE": ({"OPENBLAS_CORETYPE": "Prescott", "MKL_CBWR": "COMPATIBLE"}, set()),
}


def main() -> int:
    """Run pytest once for each processor; return the first exit code that is no 0."""
    codes = []
    for name, (told, kept) in PROCESSORS.items():
        print(f"As a processor with {name}:", flush=True)
        # numpy warns, and tests take warnings for errors, if told to leave what it has not
        features = [f for f in __cpu_dispatch__ if __cpu_features__[f] and f not in kept]
        environment = os.environ | told | {"NPY_DISABLE_CPU_FEATURES": " ".join(features)}
        command = [sys.executable, "-m", "pytest", *sys.argv[1:]]
        codes.append(subprocess.run(command, env=environment, check=False).returncode)
    return next(filter(None, codes), 0)


if __name__ == "__main__":
    sys.exit(main())
