# distance_of_the_filter (IS-3): Inside, the distance is off by so many ε (S + |t| D) / |across|, as computed.
# Of model/fast/src/adaptive/bounds.rs: 5 steps of ε (S + |t| D) / |across|.
{ eps in [0x13000000000000p-102, 0x14000000008000p-55]
  /\ |eh| <= 0x1999999999999ap-51
  /\ |ea| <= 0x17333333333333p-51
  /\ g in [0, 0x13b326b78a30f6p-57]
  /\ q in [0, 0x1e6f46508dfea2p-51]
  /\ |r1| <= 0x1p-53 /\ |r2| <= 0x1p-53
  /\ |k1| <= 0x1p-53 /\ |k2| <= 0x1p-53 /\ |k3| <= 0x1p-53 /\ |k4| <= 0x1p-53
  -> (|eh| / (1 - |ea| * g) + q * (|(1 + r1) * (1 + r2) - 1| / eps)) / ((1 + k1) * (1 + k2) * (1 + k3) * (1 + k4)) <= 0x14000000000000p-50
  /\ |ea| / (1 - |ea| * g) / ((1 + k1) * (1 + k2) * (1 + k3) * (1 + k4)) <= 0x14000000000000p-50 }
