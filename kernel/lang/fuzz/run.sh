#!/usr/bin/env bash
# Builds the fuzz targets on the stable toolchain and runs each of them.
#
#     kernel/lang/fuzz/run.sh [seconds per target, 600] [target...]
#
# Prints executions and findings of every target; a finding leaves its input in the folder it names, and the script fails.
set -euo pipefail
cd "$(dirname "$0")"

seconds=${1:-600}
shift || true
targets=("$@")
[ ${#targets[@]} -gt 0 ] || targets=(lex compile layout run formats patterns)

triple=$(rustc -vV | sed -n 's/^host: //p')
folder=${CARGO_TARGET_DIR:-$PWD/target}
work=$folder/fuzz-work
flags="-Cpasses=sancov-module"
for flag in level=4 inline-8bit-counters pc-table trace-compares; do
    flags+=" -Cllvm-args=-sanitizer-coverage-$flag"
done
CARGO_TARGET_DIR=$folder RUSTFLAGS=$flags cargo build --quiet --release --locked --target "$triple"
python3 seeds.py "$work/seeds"

findings=0
for target in "${targets[@]}"; do
    mkdir -p "$work/corpus/$target" "$work/findings/$target"
    log=$work/$target.log
    # -timeout: one input that runs longer than this many seconds is a finding; by the clock on the wall, so it leaves room
    # for a machine that is busy.
    status=0
    "$folder/$triple/release/$target" -max_total_time="$seconds" -max_len=2048 -timeout=60 -rss_limit_mb=2048 \
        -print_final_stats=1 -artifact_prefix="$work/findings/$target/" \
        "$work/corpus/$target" "$work/seeds/$target" >"$log" 2>&1 || status=$?
    runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log" | tail -1)
    coverage=$(grep -o 'cov: [0-9]*' "$log" | tail -1)
    if [ "$status" -eq 0 ]; then
        echo "$target: ${runs:-?} executions in $seconds s, $coverage, no finding"
    else
        findings=$((findings + 1))
        echo "$target: a finding after ${runs:-?} executions, see $log and $work/findings/$target"
    fi
done
[ "$findings" -eq 0 ]
