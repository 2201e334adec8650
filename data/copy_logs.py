"""Write the project's own small logs from the reference runs: `python data/copy_logs.py ../shared/data/chrono_vehicle`.

Channels are kept as they are; of the truth only what judges a force law: wheel forces, wheel-centre velocities and
road-wheel angles. One log stays CSV, as an example of the format; the others are Parquet with single-precision values,
which keeps more digits than the CSV has.
"""

import sys
from pathlib import Path

import pandas as pd

LOGS = {
    "paper_clay_n0.50": ".csv.gz",
    "paper_sandyloam_n0.70": ".parquet",
    "multi_clay_n0.50": ".parquet",
}
TRUTH = ("true_delta_", "true_fx_", "true_fy_", "true_fz_", "true_vx_", "true_vy_")


def copy(source: Path, target: Path) -> None:
    """Write the log `source` as `target`, the format told by its name."""
    table = pd.read_csv(source)
    table = table[[name for name in table.columns if not name.startswith("true_") or name.startswith(TRUTH)]]
    if target.suffix == ".parquet":
        single = table.astype({name: "float32" for name in table.columns if name != "t"})
        single.to_parquet(
            target, index=False, compression="zstd", compression_level=19, use_dictionary=False,
            use_byte_stream_split=True,
        )  # fmt: skip
    else:
        compression = {"method": "gzip", "compresslevel": 9, "mtime": 1}
        table.to_csv(target, index=False, float_format="%.6g", compression=compression)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("expected the folder of the reference runs")
    for stem, suffix in LOGS.items():
        copy(Path(sys.argv[1]) / f"{stem}.csv.gz", Path(__file__).parent / f"{stem}{suffix}")
