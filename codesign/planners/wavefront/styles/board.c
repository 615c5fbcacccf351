/* The wave of delays 2 and 3 for a board without the package: the loop of plan/kernels.py (spread) in C.

   It ends with the time at which the start is reached. plan() returns the number of reached cells and of the steps
   that are tracked (one), or -1 where there is no memory. */
#include <stdint.h>
#include <stdlib.h>

double plan(const uint8_t *free_cells, int32_t rows, int32_t columns, int32_t goal_row, int32_t goal_column,
            int32_t start_row, int32_t start_column)
{
    const int32_t stride = columns + 2, size = (rows + 2) * stride;
    const int32_t offsets[8] = {-stride, 1, stride, -1, 1 - stride, 1 + stride, stride - 1, -1 - stride};
    const int32_t start = (start_row + 1) * stride + start_column + 1;
    int32_t *potentials = malloc(size * sizeof *potentials), *order = malloc(size * sizeof *order);
    int32_t begins[4] = {0}, ends[4] = {0}, used = 1;
    double answer = -1;
    if (potentials && order) {
        for (int32_t cell = 0; cell < size; cell++)
            potentials[cell] = -2;
        for (int32_t row = 0; row < rows; row++)
            for (int32_t column = 0; column < columns; column++)
                if (free_cells[(size_t)row * columns + column])
                    potentials[(row + 1) * stride + column + 1] = -1;
        order[0] = (goal_row + 1) * stride + goal_column + 1;
        potentials[order[0]] = 0;
        ends[0] = 1;
        for (int32_t time = 1; potentials[start] < 0; time++) {
            const int32_t begin = used;
            for (int side = 0; side < 8; side++) {
                const int since = (time - (side < 4 ? 2 : 3)) & 3;
                for (int32_t each = begins[since]; each < ends[since]; each++) {
                    const int32_t cell = order[each] + offsets[side];
                    if (potentials[cell] == -1) {
                        potentials[cell] = time;
                        order[used++] = cell;
                    }
                }
            }
            begins[time & 3] = begin;
            ends[time & 3] = used;
        }
        for (int side = 0; side < 8 && potentials[start] > 0; side++) {
            const int32_t cell = start + offsets[side];
            if (potentials[cell] >= 0 && potentials[cell] + (side < 4 ? 2 : 3) == potentials[start]) {
                order[0] = cell;
                break;
            }
        }
        answer = used + 1;
    }
    free(potentials);
    free(order);
    return answer;
}
