"""One step's stages of DOP853, the explicit Runge–Kutta method of order 8 with 12 stages.

E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd edition,
section II.5. The same numbers as ``scipy.integrate.DOP853.A`` and ``.B`` (a test compares them),
kept here because loading scipy.integrate takes longer than solving a thousand rods.
"""

from numba import njit

STAGES = 12
# slopes of a state of up to this size lie that far apart in ``k``
STRIDE = 43

# row i holds what stage i takes of the slopes before it
# fmt: off
A = (
    (),
    (
        0.05260015195876773,
    ),
    (
        0.0197250569845379, 0.0591751709536137,
    ),
    (
        0.02958758547680685, 0.0, 0.08876275643042054,
    ),
    (
        0.2413651341592667, 0.0, -0.8845494793282861,
        0.924834003261792,
    ),
    (
        0.037037037037037035, 0.0, 0.0,
        0.17082860872947386, 0.12546768756682242,
    ),
    (
        0.037109375, 0.0, 0.0,
        0.17025221101954405, 0.06021653898045596, -0.017578125,
    ),
    (
        0.03709200011850479, 0.0, 0.0,
        0.17038392571223998, 0.10726203044637328, -0.015319437748624402,
        0.008273789163814023,
    ),
    (
        0.6241109587160757, 0.0, 0.0,
        -3.3608926294469414, -0.868219346841726, 27.59209969944671,
        20.154067550477894, -43.48988418106996,
    ),
    (
        0.47766253643826434, 0.0, 0.0,
        -2.4881146199716677, -0.590290826836843, 21.230051448181193,
        15.279233632882423, -33.28821096898486, -0.020331201708508627,
    ),
    (
        -0.9371424300859873, 0.0, 0.0,
        5.186372428844064, 1.0914373489967295, -8.149787010746927,
        -18.52006565999696, 22.739487099350505, 2.4936055526796523,
        -3.0467644718982196,
    ),
    (
        2.273310147516538, 0.0, 0.0,
        -10.53449546673725, -2.0008720582248625, -17.9589318631188,
        27.94888452941996, -2.8589982771350235, -8.87285693353063,
        12.360567175794303, 0.6433927460157636,
    ),
)
B = (
    0.054293734116568765, 0.0, 0.0,
    0.0, 0.0, 4.450312892752409,
    1.8915178993145003, -5.801203960010585, 0.3111643669578199,
    -0.1521609496625161, 0.20136540080403034, 0.04471061572777259,
)
# fmt: on


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def stage(y, z, k, i, h, size):
    """State of stage ``i`` from the slopes before it, z = y + h Σ A[i][j] k_j; of the end for 12.

    Written out, since a loop over j with its zeros takes four times as long. ``z`` may be ``y``.
    """
    if i == 1:
        for c in range(size):
            z[c] = y[c] + h * (A[1][0] * k[c])
    elif i == 2:
        for c in range(size):
            z[c] = y[c] + h * (A[2][0] * k[c] + A[2][1] * k[STRIDE + c])
    elif i == 3:
        for c in range(size):
            z[c] = y[c] + h * (A[3][0] * k[c] + A[3][2] * k[2 * STRIDE + c])
    elif i == 4:
        for c in range(size):
            z[c] = y[c] + h * (
                A[4][0] * k[c] + A[4][2] * k[2 * STRIDE + c] + A[4][3] * k[3 * STRIDE + c]
            )
    elif i == 5:
        for c in range(size):
            z[c] = y[c] + h * (
                A[5][0] * k[c] + A[5][3] * k[3 * STRIDE + c] + A[5][4] * k[4 * STRIDE + c]
            )
    elif i == 6:
        for c in range(size):
            z[c] = y[c] + h * (
                A[6][0] * k[c]
                + A[6][3] * k[3 * STRIDE + c]
                + A[6][4] * k[4 * STRIDE + c]
                + A[6][5] * k[5 * STRIDE + c]
            )
    elif i == 7:
        for c in range(size):
            z[c] = y[c] + h * (
                A[7][0] * k[c]
                + A[7][3] * k[3 * STRIDE + c]
                + A[7][4] * k[4 * STRIDE + c]
                + A[7][5] * k[5 * STRIDE + c]
                + A[7][6] * k[6 * STRIDE + c]
            )
    elif i == 8:
        for c in range(size):
            z[c] = y[c] + h * (
                A[8][0] * k[c]
                + A[8][3] * k[3 * STRIDE + c]
                + A[8][4] * k[4 * STRIDE + c]
                + A[8][5] * k[5 * STRIDE + c]
                + A[8][6] * k[6 * STRIDE + c]
                + A[8][7] * k[7 * STRIDE + c]
            )
    elif i == 9:
        for c in range(size):
            z[c] = y[c] + h * (
                A[9][0] * k[c]
                + A[9][3] * k[3 * STRIDE + c]
                + A[9][4] * k[4 * STRIDE + c]
                + A[9][5] * k[5 * STRIDE + c]
                + A[9][6] * k[6 * STRIDE + c]
                + A[9][7] * k[7 * STRIDE + c]
                + A[9][8] * k[8 * STRIDE + c]
            )
    elif i == 10:
        for c in range(size):
            z[c] = y[c] + h * (
                A[10][0] * k[c]
                + A[10][3] * k[3 * STRIDE + c]
                + A[10][4] * k[4 * STRIDE + c]
                + A[10][5] * k[5 * STRIDE + c]
                + A[10][6] * k[6 * STRIDE + c]
                + A[10][7] * k[7 * STRIDE + c]
                + A[10][8] * k[8 * STRIDE + c]
                + A[10][9] * k[9 * STRIDE + c]
            )
    elif i == 11:
        for c in range(size):
            z[c] = y[c] + h * (
                A[11][0] * k[c]
                + A[11][3] * k[3 * STRIDE + c]
                + A[11][4] * k[4 * STRIDE + c]
                + A[11][5] * k[5 * STRIDE + c]
                + A[11][6] * k[6 * STRIDE + c]
                + A[11][7] * k[7 * STRIDE + c]
                + A[11][8] * k[8 * STRIDE + c]
                + A[11][9] * k[9 * STRIDE + c]
                + A[11][10] * k[10 * STRIDE + c]
            )
    else:
        for c in range(size):
            z[c] = y[c] + h * (
                B[0] * k[c]
                + B[5] * k[5 * STRIDE + c]
                + B[6] * k[6 * STRIDE + c]
                + B[7] * k[7 * STRIDE + c]
                + B[8] * k[8 * STRIDE + c]
                + B[9] * k[9 * STRIDE + c]
                + B[10] * k[10 * STRIDE + c]
                + B[11] * k[11 * STRIDE + c]
            )
