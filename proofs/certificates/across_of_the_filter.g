# across_of_the_filter (IS-3): The direction's component across the plane is off by so many ε D.
# Of model/fast/src/adaptive/bounds.rs: 2.9 steps of ε D.
p0 = P0 + eps * x0;
p1 = P1 + eps * x1;
A = d0 + (P0 * d1 + P1 * d2);
a = (d0 + (p0 * d1 * (1 + r1) + p1 * d2 * (1 + r2)) * (1 + r3)) * (1 + r4);
{ eps in [0x13000000000000p-102, 0x14000000008000p-55] /\ |P0| <= 0x12222222222223p-52 /\ |P1| <= 0x12222222222223p-52 /\ |x0| <= 1 /\ |x1| <= 1
  /\ |d0| <= 1 /\ |d1| <= 1 /\ |d2| <= 1
  /\ |r1| <= 0x1p-53 /\ |r2| <= 0x1p-53 /\ |r3| <= 0x1p-53 /\ |r4| <= 0x1p-53
  -> |(a - A) / eps| <= 0x17333333333333p-51 }
(a - A) / eps -> d0 * (r4 / eps) + P0 * d1 * (((1 + r1) * (1 + r3) * (1 + r4) - 1) / eps) + x0 * d1 * ((1 + r1) * (1 + r3) * (1 + r4)) + P1 * d2 * (((1 + r2) * (1 + r3) * (1 + r4) - 1) / eps) + x1 * d2 * ((1 + r2) * (1 + r3) * (1 + r4)) { eps <> 0 };
