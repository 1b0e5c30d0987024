"""One step's stages of DOP853, the explicit Runge–Kutta method of order 8 with 12 stages.

E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd edition,
section II.5. The same numbers as ``scipy.integrate.DOP853.A`` and ``.B`` (a test compares them),
kept here because loading scipy.integrate takes longer than solving a thousand rods.
"""

from loopelastica.rod.kernels.jit import kernel

STAGES = 12
# size of a state; its slopes lie that far apart in ``k``
STRIDE = 43

# Ai_j is what stage i takes of slope j; the others are zero. Names rather than a table: numba would
# build the whole table anew at each use
A1_0 = 0.05260015195876773
A2_0 = 0.0197250569845379
A2_1 = 0.0591751709536137
A3_0 = 0.02958758547680685
A3_2 = 0.08876275643042054
A4_0 = 0.2413651341592667
A4_2 = -0.8845494793282861
A4_3 = 0.924834003261792
A5_0 = 0.037037037037037035
A5_3 = 0.17082860872947386
A5_4 = 0.12546768756682242
A6_0 = 0.037109375
A6_3 = 0.17025221101954405
A6_4 = 0.06021653898045596
A6_5 = -0.017578125
A7_0 = 0.03709200011850479
A7_3 = 0.17038392571223998
A7_4 = 0.10726203044637328
A7_5 = -0.015319437748624402
A7_6 = 0.008273789163814023
A8_0 = 0.6241109587160757
A8_3 = -3.3608926294469414
A8_4 = -0.868219346841726
A8_5 = 27.59209969944671
A8_6 = 20.154067550477894
A8_7 = -43.48988418106996
A9_0 = 0.47766253643826434
A9_3 = -2.4881146199716677
A9_4 = -0.590290826836843
A9_5 = 21.230051448181193
A9_6 = 15.279233632882423
A9_7 = -33.28821096898486
A9_8 = -0.020331201708508627
A10_0 = -0.9371424300859873
A10_3 = 5.186372428844064
A10_4 = 1.0914373489967295
A10_5 = -8.149787010746927
A10_6 = -18.52006565999696
A10_7 = 22.739487099350505
A10_8 = 2.4936055526796523
A10_9 = -3.0467644718982196
A11_0 = 2.273310147516538
A11_3 = -10.53449546673725
A11_4 = -2.0008720582248625
A11_5 = -17.9589318631188
A11_6 = 27.94888452941996
A11_7 = -2.8589982771350235
A11_8 = -8.87285693353063
A11_9 = 12.360567175794303
A11_10 = 0.6433927460157636
B_0 = 0.054293734116568765
B_5 = 4.450312892752409
B_6 = 1.8915178993145003
B_7 = -5.801203960010585
B_8 = 0.3111643669578199
B_9 = -0.1521609496625161
B_10 = 0.20136540080403034
B_11 = 0.04471061572777259


@kernel
def stage(y, z, k, i, h):
    """State of stage ``i`` from the slopes before it, z = y + h Σ Ai_j k_j; of the end for 12.

    Written out, since a loop over j with its zeros takes four times as long. ``z`` may be ``y``.
    Strict arithmetic: contracted to fused operations, the last bit would depend on where the
    compiler inlines this, and so on the process.
    """
    if i == 1:
        for c in range(STRIDE):
            z[c] = y[c] + h * (A1_0 * k[c])
    elif i == 2:
        for c in range(STRIDE):
            z[c] = y[c] + h * (A2_0 * k[c] + A2_1 * k[STRIDE + c])
    elif i == 3:
        for c in range(STRIDE):
            z[c] = y[c] + h * (A3_0 * k[c] + A3_2 * k[2 * STRIDE + c])
    elif i == 4:
        for c in range(STRIDE):
            z[c] = y[c] + h * (A4_0 * k[c] + A4_2 * k[2 * STRIDE + c] + A4_3 * k[3 * STRIDE + c])
    elif i == 5:
        for c in range(STRIDE):
            z[c] = y[c] + h * (A5_0 * k[c] + A5_3 * k[3 * STRIDE + c] + A5_4 * k[4 * STRIDE + c])
    elif i == 6:
        for c in range(STRIDE):
            z[c] = y[c] + h * (
                A6_0 * k[c]
                + A6_3 * k[3 * STRIDE + c]
                + A6_4 * k[4 * STRIDE + c]
                + A6_5 * k[5 * STRIDE + c]
            )
    elif i == 7:
        for c in range(STRIDE):
            z[c] = y[c] + h * (
                A7_0 * k[c]
                + A7_3 * k[3 * STRIDE + c]
                + A7_4 * k[4 * STRIDE + c]
                + A7_5 * k[5 * STRIDE + c]
                + A7_6 * k[6 * STRIDE + c]
            )
    elif i == 8:
        for c in range(STRIDE):
            z[c] = y[c] + h * (
                A8_0 * k[c]
                + A8_3 * k[3 * STRIDE + c]
                + A8_4 * k[4 * STRIDE + c]
                + A8_5 * k[5 * STRIDE + c]
                + A8_6 * k[6 * STRIDE + c]
                + A8_7 * k[7 * STRIDE + c]
            )
    elif i == 9:
        for c in range(STRIDE):
            z[c] = y[c] + h * (
                A9_0 * k[c]
                + A9_3 * k[3 * STRIDE + c]
                + A9_4 * k[4 * STRIDE + c]
                + A9_5 * k[5 * STRIDE + c]
                + A9_6 * k[6 * STRIDE + c]
                + A9_7 * k[7 * STRIDE + c]
                + A9_8 * k[8 * STRIDE + c]
            )
    elif i == 10:
        for c in range(STRIDE):
            z[c] = y[c] + h * (
                A10_0 * k[c]
                + A10_3 * k[3 * STRIDE + c]
                + A10_4 * k[4 * STRIDE + c]
                + A10_5 * k[5 * STRIDE + c]
                + A10_6 * k[6 * STRIDE + c]
                + A10_7 * k[7 * STRIDE + c]
                + A10_8 * k[8 * STRIDE + c]
                + A10_9 * k[9 * STRIDE + c]
            )
    elif i == 11:
        for c in range(STRIDE):
            z[c] = y[c] + h * (
                A11_0 * k[c]
                + A11_3 * k[3 * STRIDE + c]
                + A11_4 * k[4 * STRIDE + c]
                + A11_5 * k[5 * STRIDE + c]
                + A11_6 * k[6 * STRIDE + c]
                + A11_7 * k[7 * STRIDE + c]
                + A11_8 * k[8 * STRIDE + c]
                + A11_9 * k[9 * STRIDE + c]
                + A11_10 * k[10 * STRIDE + c]
            )
    else:
        for c in range(STRIDE):
            z[c] = y[c] + h * (
                B_0 * k[c]
                + B_5 * k[5 * STRIDE + c]
                + B_6 * k[6 * STRIDE + c]
                + B_7 * k[7 * STRIDE + c]
                + B_8 * k[8 * STRIDE + c]
                + B_9 * k[9 * STRIDE + c]
                + B_10 * k[10 * STRIDE + c]
                + B_11 * k[11 * STRIDE + c]
            )
