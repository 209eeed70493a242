// Sums over the 256 lanes of a workgroup.

var<workgroup> lane_sums: array<u32, 256>;

struct LaneSum {
    // Of all lanes before this one.
    before: u32,
    // Of all lanes.
    total: u32,
}

fn sum_of_lanes(lane: u32, value: u32) -> LaneSum {
    lane_sums[lane] = value;
    workgroupBarrier();
    for (var reach = 1u; reach < 256u; reach *= 2u) {
        var sum = lane_sums[lane];
        if lane >= reach {
            sum += lane_sums[lane - reach];
        }
        workgroupBarrier();
        lane_sums[lane] = sum;
        workgroupBarrier();
    }
    let total = workgroupUniformLoad(&lane_sums[255]);
    return LaneSum(lane_sums[lane] - value, total);
}
