# weight_of_the_filter (IS-3): The weight of the second or the third corner, times across, is off by so many L ε S D.
# Of model/fast/src/adaptive/bounds.rs: 32 steps of L ε S D.
vx = W0 * (1 + eps * q0);
vy = W1 * (1 + eps * q1);
x = X + eps * ex;
y = Y + eps * ey;
w = (vx * x * (1 + r1) + vy * y * (1 + r2)) * (1 + r3);
T = W0 * X + W1 * Y;
{ eps in [0x13000000000000p-102, 0x14000000008000p-55]
  /\ |W0| <= 1 /\ |W1| <= 1
  /\ |X| <= 0x1a222222222223p-50 /\ |Y| <= 0x1a222222222223p-50
  /\ |ex| <= 0x1f99999999999ap-50 /\ |ey| <= 0x1f99999999999ap-50
  /\ |q0| <= 1 /\ |q1| <= 1
  /\ |r1| <= 0x1p-53 /\ |r2| <= 0x1p-53 /\ |r3| <= 0x1p-53
  -> |(w - T) / eps| <= 0x10000000000000p-47 }
(w - T) / eps -> W0 * X * (((1 + r1) * (1 + r3) - 1) / eps) + W0 * ((1 + r1) * (1 + r3)) * (ex * (1 + eps * q0) + q0 * X) + W1 * Y * (((1 + r2) * (1 + r3) - 1) / eps) + W1 * ((1 + r2) * (1 + r3)) * (ey * (1 + eps * q1) + q1 * Y) { eps <> 0 };
