"""What the page takes for granted: an archive."""

import chaosdrill as cd

cd.save(cd.poincare_section(cd.build("impact-oscillator"), periods=200), "OUT.nc")
