# height_of_the_filter (IS-3): The origin's height over the plane is off by so many ε S.
# Of model/fast/src/adaptive/bounds.rs: 3.2 steps of ε S.
p0 = P0 + eps * x0;
p1 = P1 + eps * x1;
H = f0 + (P0 * f1 + P1 * f2);
h = (f0 * (1 + s0) + (p0 * (f1 * (1 + s1)) * (1 + r1) + p1 * (f2 * (1 + s2)) * (1 + r2)) * (1 + r3)) * (1 + r4);
{ eps in [0x13000000000000p-102, 0x14000000008000p-55] /\ |P0| <= 0x12222222222223p-52 /\ |P1| <= 0x12222222222223p-52 /\ |x0| <= 1 /\ |x1| <= 1
  /\ |f0| <= 1 /\ |f1| <= 1 /\ |f2| <= 1
  /\ |s0| <= 0x1p-53 /\ |s1| <= 0x1p-53 /\ |s2| <= 0x1p-53 /\ |r1| <= 0x1p-53 /\ |r2| <= 0x1p-53 /\ |r3| <= 0x1p-53 /\ |r4| <= 0x1p-53
  -> |(h - H) / eps| <= 0x1999999999999ap-51 }
(h - H) / eps -> f0 * (((1 + s0) * (1 + r4) - 1) / eps) + P0 * f1 * (((1 + s1) * (1 + r1) * (1 + r3) * (1 + r4) - 1) / eps) + x0 * f1 * ((1 + s1) * (1 + r1) * (1 + r3) * (1 + r4)) + P1 * f2 * (((1 + s2) * (1 + r2) * (1 + r3) * (1 + r4) - 1) / eps) + x1 * f2 * ((1 + s2) * (1 + r2) * (1 + r3) * (1 + r4)) { eps <> 0 };
