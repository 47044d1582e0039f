# distance_to_a_plane (KD-3): The distance to a plane is the true one times 1 + e, |e| at most γ(3), u = 2^-24.
# Of model/spec/src/rays/interval.rs: 3 steps of n of γ(n).
{ |d1| <= 0x1p-24 /\ |d2| <= 0x1p-24 /\ |d3| <= 0x1p-24 -> |(1 + d1) * (1 + d2) * (1 + d3) - 1| <= 0x180000480000d9p-75 }
