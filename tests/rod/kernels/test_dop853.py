import numpy as np


def test_the_table_of_the_method_is_scipys():
    from scipy.integrate import DOP853

    from loopelastica.rod.kernels import dop853

    names = vars(dop853)
    for i in range(12):
        ours = [names.get(f"A{i}_{j}", 0.0) for j in range(12)]
        np.testing.assert_array_equal(ours, DOP853.A[i, :12])
    np.testing.assert_array_equal([names.get(f"B_{j}", 0.0) for j in range(12)], DOP853.B)
