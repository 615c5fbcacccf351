/* Breadth-first search for a board without the package: the loop of plan/kernels.py (trail, mark_path) in C.

   plan() returns the number of popped cells, or -1 where there is no memory. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

double plan(const uint8_t *free_cells, int32_t rows, int32_t columns, int32_t goal_row, int32_t goal_column,
            int32_t start_row, int32_t start_column)
{
    const int32_t stride = columns + 2, size = (rows + 2) * stride;
    const int32_t offsets[4] = {-stride, stride, -1, 1};
    const int32_t goal = (goal_row + 1) * stride + goal_column + 1;
    const int32_t start = (start_row + 1) * stride + start_column + 1;
    uint8_t *cells = calloc(size, 1);
    int8_t *directions = malloc(size);
    int32_t *queue = malloc(size * sizeof *queue);
    int32_t popped = 0, pushed = 1, cell = start, steps = 0;
    double answer = -1;
    if (cells && directions && queue) {
        memset(directions, -1, size);
        for (int32_t row = 0; row < rows; row++)
            memcpy(cells + (row + 1) * stride + 1, free_cells + (size_t)row * columns, columns);
        cells[start] = 0;
        queue[0] = start;
        while (popped < pushed) {
            cell = queue[popped++];
            if (cell == goal)
                break;
            for (int side = 0; side < 4; side++) {
                const int32_t neighbour = cell + offsets[side];
                if (cells[neighbour]) {
                    cells[neighbour] = 0;
                    directions[neighbour] = (int8_t)(side ^ 1);
                    queue[pushed++] = neighbour;
                }
            }
        }
        while (directions[cell] >= 0) {
            cell += offsets[directions[cell]];
            queue[steps++] = cell;
        }
        answer = popped;
    }
    free(cells);
    free(directions);
    free(queue);
    return answer;
}
