// Turns counts into the places where each brick's voxels begin. Second step of the compaction; one workgroup does it all.

struct Params {
    bricks: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
// In: counts. Out: sums of the counts before; the sum of all behind them.
@group(0) @binding(1) var<storage, read_write> counts: array<u32>;

var<workgroup> sums: array<u32, 256>;

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) thread: u32) {
    let share = (params.bricks + 255u) / 256u;
    let first = min(thread * share, params.bricks);
    let end = min(first + share, params.bricks);
    var sum = 0u;
    for (var i = first; i < end; i++) {
        sum += counts[i];
    }
    sums[thread] = sum;
    workgroupBarrier();
    for (var step = 1u; step < 256u; step *= 2u) {
        var more = 0u;
        if thread >= step {
            more = sums[thread - step];
        }
        workgroupBarrier();
        sums[thread] += more;
        workgroupBarrier();
    }
    var before = sums[thread] - sum;
    for (var i = first; i < end; i++) {
        let count = counts[i];
        counts[i] = before;
        before += count;
    }
    if thread == 255u {
        counts[params.bricks] = before;
    }
}
